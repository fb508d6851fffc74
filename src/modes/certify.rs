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
//! All of this takes magnitudes and differences of quotients only ([`Couplings`]): doubles, whatever
//! the precision in which they were found.
//!
//! The same τ bounds eigenvectors: for an eigenvalue in the interval the rows outside C read
//! |h_ii| |y_i| <= Σ |h_ic| |y_c| + Σ |h_ij| |y_j|, and since the comparison matrix of the rows
//! outside is a nonsingular M-matrix (its inverse is not negative), |y_i| <= τ_i max_c |y_c|.

use super::dense::Plain;
use crate::precision::up;

/// Neighbouring eigenvalues that the bounds do not separate, or a single one.
pub(super) struct Cluster {
    /// Positions in [`Couplings::order`], from `start` up to but not including `end`.
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

/// What is proved about a pencil.
pub(super) struct Enclosures {
    /// By rising position: the k-th eigenvalue is no further than this from the k-th quotient.
    pub(super) radii: Vec<f64>,
    /// The clusters by rising position; together they hold every position once.
    pub(super) clusters: Vec<Cluster>,
}

/// How the columns of a nearly diagonal pencil are coupled: its entries as bounds in doubles.
/// μ_i stands for a number close to s_ii / g_ii, the quotient of column i.
#[derive(Clone)]
pub(super) struct Couplings {
    /// The columns by rising quotient.
    pub(super) order: Vec<usize>,
    /// The distances between neighbouring quotients in this order, one less than there are columns,
    /// each within a factor 1 ± 2^-50.
    pub(super) steps: Vec<f64>,
    /// Upper bounds of |μ_i|.
    pub(super) size: Vec<f64>,
    /// Upper bounds of |s_ii - μ_i g_ii|.
    pub(super) defect: Vec<f64>,
    /// Bounds of g_ii from below and above.
    pub(super) least: Vec<f64>,
    pub(super) most: Vec<f64>,
    /// Upper bounds of |s_ij - μ_j g_ij| off the diagonal, 0 on it.
    pub(super) h: Plain,
    /// Upper bounds of |g_ij| off the diagonal, 0 on it.
    pub(super) g: Plain,
}

impl Couplings {
    /// Columns that are not coupled at all, in no order yet.
    pub(super) fn zeros(columns: usize) -> Self {
        Self {
            order: Vec::new(),
            steps: Vec::new(),
            size: vec![0.0; columns],
            defect: vec![0.0; columns],
            least: vec![0.0; columns],
            most: vec![0.0; columns],
            h: Plain::zeros(columns, columns),
            g: Plain::zeros(columns, columns),
        }
    }
}

/// What the rows of the pencil contribute to every cluster's bound.
struct Rows<'a> {
    couplings: &'a Couplings,
    /// Scaling in which off-diagonal sums are taken: about |μ|^(-1/2), so that graded problems
    /// are judged grade by grade.
    weight: Vec<f64>,
    /// Σ_{j≠i} |s_ij| w_j and Σ_{j≠i} |g_ij| w_j.
    s_sum: Vec<f64>,
    g_sum: Vec<f64>,
}

/// A bound of the relative error of a sum of `terms` nonnegative doubles that are themselves within
/// a factor 1 ± 2^-50.
fn slack(terms: usize) -> f64 {
    4.0 * (terms as f64 + 16.0) * f64::EPSILON
}

/// Encloses all eigenvalues. `None` if G is not shown to be within 1/2 of the unit matrix: then
/// neither is M shown to be positive definite.
pub(super) fn certify(couplings: &Couplings) -> Option<Enclosures> {
    let rows = Rows::new(couplings)?;
    let m = couplings.order.len();
    let mut radii = vec![0.0; m];
    // Accepted clusters below, ranges still to be shown above; a range that fails is joined with
    // the neighbour that it could not be told from.
    let mut clusters: Vec<Cluster> = Vec::with_capacity(m);
    let mut gaps = vec![0.0; m];
    let mut start = 0;
    let mut end = 1;
    while start < m {
        match rows.enclose(start, end, &mut gaps) {
            Ok((radius, reach)) => {
                let mut below = 0.0;
                let factor = 1.0 + slack(m);
                for (position, radius) in radii[start..end].iter_mut().enumerate() {
                    *radius = below;
                    let step = couplings.steps.get(start + position);
                    below += step.copied().unwrap_or(0.0) * factor;
                }
                let mut above: f64 = 0.0;
                for position in (start..end).rev() {
                    radii[position] = up(radii[position].max(above) * factor + radius);
                    if position > start {
                        above += couplings.steps[position - 1] * factor;
                    }
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
    Some(Enclosures { radii, clusters })
}

impl<'a> Rows<'a> {
    fn new(couplings: &'a Couplings) -> Option<Self> {
        let m = couplings.order.len();
        let finite = |x: &[f64]| x.iter().all(|x| x.is_finite());
        if !finite(&couplings.size) || !finite(&couplings.defect) || !finite(&couplings.steps) {
            return None;
        }
        let largest = couplings.size.iter().fold(0.0_f64, |x, &mu| x.max(mu));
        let floor = largest * 1e-30 + 1e-290;
        let weight: Vec<f64> = couplings
            .size
            .iter()
            .map(|mu| 1.0 / (mu + floor).sqrt())
            .collect();
        // |s_ij| <= |s_ij - μ_j g_ij| + |μ_j| |g_ij|
        let sizes: Vec<f64> = couplings
            .size
            .iter()
            .zip(&weight)
            .map(|(s, w)| s * w)
            .collect();
        let (mut s_sum, mut g_sum, mut plain) = (vec![0.0; m], vec![0.0; m], vec![0.0; m]);
        for j in 0..m {
            let (h, g) = (couplings.h.column(j), couplings.g.column(j));
            let (w, v) = (weight[j], sizes[j]);
            for i in 0..m {
                s_sum[i] += h[i] * w + g[i] * v;
                g_sum[i] += g[i] * w;
                plain[i] += g[i];
            }
        }
        let factor = 1.0 + slack(2 * m);
        for i in 0..m {
            s_sum[i] *= factor;
            g_sum[i] *= factor;
            let close = couplings.least[i] - plain[i] * factor >= 0.5 && couplings.most[i] <= 1.5;
            if !close || !s_sum[i].is_finite() {
                return None;
            }
        }
        Some(Self {
            couplings,
            weight,
            s_sum,
            g_sum,
        })
    }

    /// About max_c (|s_cc - μ_c g_cc| + Σ_{c'} |h_cc'| + Σ_i h_ci² / gap_i).
    fn estimate(&self, start: usize, end: usize, gaps: &[f64]) -> f64 {
        let Couplings {
            order, defect, h, ..
        } = self.couplings;
        let mut most: f64 = 0.0;
        for &c in &order[start..end] {
            let column = h.column(c);
            let mut sum = defect[c];
            for positions in [0..start, end..order.len()] {
                for (&i, gap) in order[positions.clone()].iter().zip(&gaps[positions]) {
                    sum += column[i] * column[i] / gap;
                }
            }
            for &i in &order[start..end] {
                sum += column[i];
            }
            most = most.max(sum);
        }
        most
    }

    /// The radius r and the reach τ of the positions `start..end`, or the position of a
    /// row that they cannot be separated from. `gaps` is memory to work in.
    fn enclose(
        &self,
        start: usize,
        end: usize,
        gaps: &mut [f64],
    ) -> Result<(f64, Vec<f64>), usize> {
        let Couplings {
            order,
            steps,
            size,
            defect,
            least,
            h,
            g,
            ..
        } = self.couplings;
        let m = order.len();
        let factor = 1.0 + slack(m);
        let width = up(steps[start..end - 1].iter().sum::<f64>() * factor);
        let sigma = order[start..end]
            .iter()
            .fold(0.0_f64, |x, &c| x.max(size[c]));
        // Gaps between rows outside and the cluster, from below: sums of nonnegative numbers.
        let lower = 1.0 - slack(m);
        let mut sum = 0.0;
        for position in (0..start).rev() {
            sum += steps[position];
            gaps[position] = sum * lower;
        }
        sum = 0.0;
        for position in end..m {
            sum += steps[position - 1];
            gaps[position] = sum * lower;
        }
        let outside = || (0..start).chain(end..m);
        let mut tau = vec![0.0; m];
        // Twice what the radius comes to if the columns are hardly coupled: mostly enough at once.
        let mut radius = 2.0 * self.estimate(start, end, gaps);
        if !radius.is_finite() {
            radius = 0.0;
        }
        for _ in 0..10 {
            let reach = width + radius;
            // |s_ic - σ g_ic| <= |s_ic - μ_c g_ic| + |σ - μ_c| |g_ic| for columns c of the cluster.
            tau.fill(0.0);
            for &c in &order[start..end] {
                for ((tau, h), g) in tau.iter_mut().zip(h.column(c)).zip(g.column(c)) {
                    *tau += h + reach * g;
                }
            }
            let (mut most, mut culprit): (f64, Option<(f64, usize)>) = (0.0, None);
            for position in outside() {
                let i = order[position];
                let distance = gaps[position];
                let diagonal = (distance - radius) * least[i] * (1.0 - 1e-14) - defect[i];
                let rest = self.s_sum[i] + (sigma + radius) * self.g_sum[i];
                let margin = diagonal * self.weight[i] * (1.0 - 1e-14) - rest * factor;
                if margin > 0.0 {
                    most = most.max(tau[i] * factor / margin);
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
                let diagonal = (gaps[position] - radius) * least[i] * (1.0 - 1e-14) - defect[i];
                let rest = (self.s_sum[i] + (sigma + radius) * self.g_sum[i]) * most;
                tau[i] = up((tau[i] + rest) * factor / (diagonal * (1.0 - 1e-14)));
            }
            for &c in &order[start..end] {
                tau[c] = 0.0;
            }
            let mut needed: f64 = 0.0;
            for &c in &order[start..end] {
                let (h, g) = (h.column(c), g.column(c));
                let mut sum = defect[c];
                for ((tau, h), g) in tau.iter().zip(h).zip(g) {
                    sum += (h + reach * g) * tau;
                }
                for &i in &order[start..end] {
                    sum += h[i] + reach * g[i];
                }
                needed = needed.max(sum * factor / least[c]);
            }
            // With a smaller radius every condition is easier: the needed one will do.
            let needed = if needed == 0.0 {
                0.0
            } else {
                up(needed * (1.0 + 1e-12))
            };
            if needed <= radius {
                return Ok((needed, tau));
            }
            radius = 2.0 * needed;
        }
        // The radius runs away: join the nearest.
        outside()
            .min_by(|&p, &q| gaps[p].total_cmp(&gaps[q]))
            .map_or(Ok((f64::INFINITY, tau)), Err)
    }
}
