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

use std::borrow::Cow;
use std::ops::Range;

use super::dense::Plain;
use crate::precision::{kernel, up};

/// Neighbouring eigenvalues that the bounds do not separate, or a single one.
pub(super) struct Cluster {
    /// Positions in [`Couplings::order`], from `start` up to but not including `end`.
    pub(super) start: usize,
    pub(super) end: usize,
    /// τ by column: how far eigenvectors of the cluster may reach out to other columns.
    pub(super) reach: Vec<f64>,
    /// About their sum, to 1e-9.
    pub(super) total: f64,
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

/// What the rows of the pencil contribute to every cluster's bound. Everything stands by position, padded to whole
/// lanes as columns of matrices are.
struct Rows<'a> {
    couplings: &'a Couplings,
    h: Cow<'a, Plain>,
    g: Cow<'a, Plain>,
    size: Vec<f64>,
    defect: Vec<f64>,
    least: Vec<f64>,
    /// Scaling in which off-diagonal sums are taken: about |μ|^(-1/2), so that graded problems
    /// are judged grade by grade.
    weight: Vec<f64>,
    /// Σ_{j≠i} |s_ij| w_j and Σ_{j≠i} |g_ij| w_j.
    s_sum: Vec<f64>,
    g_sum: Vec<f64>,
}

/// A bound of the relative error of a sum of `terms` nonnegative doubles that are themselves within
/// a factor 1 ± 2^-50.
pub(super) fn slack(terms: usize) -> f64 {
    4.0 * (terms as f64 + 16.0) * f64::EPSILON
}

/// Encloses all eigenvalues. `None` if G is not shown to be
/// within 1/2 of the unit matrix: then neither is M shown to be positive definite.
pub(super) fn certify(couplings: &Couplings) -> Option<Enclosures> {
    let m = couplings.order.len();
    let in_order = couplings.order.iter().enumerate().all(|(at, to)| at == *to);
    let rows = Rows::new(couplings, in_order)?;
    let mut radii = vec![0.0; m];
    // Accepted clusters below, ranges still to be shown above; a range that fails is joined with
    // the neighbour that it could not be told from.
    let mut clusters: Vec<Cluster> = Vec::with_capacity(m);
    let mut gaps = vec![f64::INFINITY; rows.h.stride];
    let mut start = 0;
    let mut end = 1;
    while start < m {
        match rows.enclose(start, end, &mut gaps) {
            Ok(Separated { radius, reach }) => {
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
                clusters.push(Cluster { start, end, total: reach.iter().sum(), reach });
                start = end;
                end = start + 1;
            }
            Err(culprit) => {
                if culprit < start {
                    start = clusters.pop()?.start;
                } else {
                    end = (end + 1).min(m);
                }
            }
        }
    }
    if !in_order {
        for cluster in &mut clusters {
            let mut by_column = vec![0.0; cluster.reach.len()];
            for (&column, tau) in couplings.order.iter().zip(&cluster.reach) {
                by_column[column] = *tau;
            }
            cluster.reach = by_column;
        }
    }
    Some(Enclosures { radii, clusters })
}

/// A cluster apart from all other rows.
struct Separated {
    /// r.
    radius: f64,
    /// τ, by position.
    reach: Vec<f64>,
}

impl<'a> Rows<'a> {
    fn new(couplings: &'a Couplings, in_order: bool) -> Option<Self> {
        let order = &couplings.order;
        let m = order.len();
        let finite = |x: &[f64]| x.iter().all(|x| x.is_finite());
        if !finite(&couplings.size) || !finite(&couplings.defect) || !finite(&couplings.steps) {
            return None;
        }
        let sorted = |a: &'a Plain| {
            if in_order {
                return Cow::Borrowed(a);
            }
            let mut by_position = Plain::zeros(m, m);
            for (position, &column) in order.iter().enumerate() {
                let from = a.column(column);
                let to = by_position.column_mut(position).iter_mut();
                to.zip(order).for_each(|(to, &row)| *to = from[row]);
            }
            Cow::Owned(by_position)
        };
        let (h, g) = (sorted(&couplings.h), sorted(&couplings.g));
        let padded = |values: &[f64], rest: f64| {
            let values = order.iter().map(|&column| values[column]);
            let rest = std::iter::repeat(rest);
            values.chain(rest).take(h.stride).collect::<Vec<f64>>()
        };
        let size = padded(&couplings.size, 0.0);
        let defect = padded(&couplings.defect, 0.0);
        let least = padded(&couplings.least, 1.0);
        let most = padded(&couplings.most, 1.0);
        let largest = size.iter().fold(0.0_f64, |x, &mu| x.max(mu));
        let floor = largest * 1e-30 + 1e-290;
        let weight: Vec<f64> = size.iter().map(|mu| 1.0 / (mu + floor).sqrt()).collect();
        let mut sums = Sums { s: vec![0.0; h.stride], g: vec![0.0; h.stride], plain: vec![0.0; h.stride] };
        run_sums(&h, &g, &size, &weight, &mut sums);
        let factor = 1.0 + slack(2 * m);
        for i in 0..m {
            sums.s[i] *= factor;
            sums.g[i] *= factor;
            let close = least[i] - sums.plain[i] * factor >= 0.5 && most[i] <= 1.5;
            if !close || !sums.s[i].is_finite() {
                return None;
            }
        }
        Some(Self { couplings, h, g, size, defect, least, weight, s_sum: sums.s, g_sum: sums.g })
    }

    /// What encloses the positions `start..end`, or the position of a row that they cannot be separated from. `gaps` is memory to work
    /// in.
    fn enclose(&self, start: usize, end: usize, gaps: &mut [f64]) -> Result<Separated, usize> {
        let steps = &self.couplings.steps;
        let m = self.couplings.order.len();
        let factor = 1.0 + slack(m);
        let width = up(steps[start..end - 1].iter().sum::<f64>() * factor);
        let sigma = self.size[start..end].iter().fold(0.0_f64, |x, &mu| x.max(mu));
        // Gaps between rows outside and the cluster, from below: sums of nonnegative numbers. None is between
        // rows of the cluster, and none where columns are padded.
        let lower = 1.0 - slack(m);
        let mut sum = 0.0;
        for (gap, step) in gaps[..start].iter_mut().zip(&steps[..start]).rev() {
            sum += step;
            *gap = sum * lower;
        }
        gaps[start..end].fill(f64::INFINITY);
        sum = 0.0;
        for (gap, step) in gaps[end..m].iter_mut().zip(&steps[end - 1..]) {
            sum += step;
            *gap = sum * lower;
        }
        let mut pass = Pass {
            rows: self,
            range: start..end,
            gaps,
            factor,
            sigma,
            width,
            radius: 0.0,
            tau: vec![0.0; self.h.stride],
            separated: true,
            needed: 0.0,
        };
        // Twice what the radius comes to if the columns are hardly coupled: mostly enough at once.
        run_estimate(&mut pass);
        pass.radius = if pass.needed.is_finite() { 2.0 * pass.needed } else { 0.0 };
        for _ in 0..10 {
            run_pass(&mut pass);
            if !pass.separated {
                return Err(pass.culprit(m));
            }
            // With a smaller radius every condition is easier: the needed one will do.
            let needed = if pass.needed == 0.0 { 0.0 } else { up(pass.needed * (1.0 + 1e-12)) };
            if needed <= pass.radius {
                pass.tau.truncate(m);
                return Ok(Separated { radius: needed, reach: pass.tau });
            }
            if !needed.is_finite() {
                break;
            }
            pass.radius = 2.0 * needed;
        }
        // The radius runs away: join the nearest.
        let Pass { gaps, mut tau, .. } = pass;
        tau.truncate(m);
        let nearest = (0..start).chain(end..m).min_by(|&p, &q| gaps[p].total_cmp(&gaps[q]));
        nearest.map_or(Ok(Separated { radius: f64::INFINITY, reach: tau }), Err)
    }
}

struct Sums {
    s: Vec<f64>,
    g: Vec<f64>,
    plain: Vec<f64>,
}

/// The radius of one cluster tried once.
struct Pass<'a> {
    rows: &'a Rows<'a>,
    range: Range<usize>,
    gaps: &'a [f64],
    factor: f64,
    /// The largest |μ| of the cluster, and how far apart its quotients are.
    sigma: f64,
    width: f64,
    /// The radius that is tried.
    radius: f64,
    /// What comes out: τ, whether all rows outside are dominant, and the radius that this takes.
    tau: Vec<f64>,
    separated: bool,
    needed: f64,
}

const LANES: usize = 4;

kernel!(run_sums, sum_loops, (h: &Plain, g: &Plain, size: &[f64], weight: &[f64], sums: &mut Sums));
kernel!(run_estimate, estimate_loops, (pass: &mut Pass<'_>));
kernel!(run_pass, pass_loops, (pass: &mut Pass<'_>));

/// A lower bound of |s_ii - λ g_ii| for λ at least `distance` away from μ_i.
#[inline(always)]
fn diagonal(distance: f64, least: f64, defect: f64) -> f64 {
    distance * least * (1.0 - 1e-14) - defect
}

/// By how much, at least, a row with this diagonal is dominant, in its weight.
#[inline(always)]
fn margin(diagonal: f64, weight: f64, rest: f64, factor: f64) -> f64 {
    diagonal * weight * (1.0 - 1e-14) - rest * factor
}

/// |s_ij| <= |s_ij - μ_j g_ij| + |μ_j| |g_ij|
#[inline(always)]
fn sum_loops<const FUSED: bool>(h: &Plain, g: &Plain, size: &[f64], weight: &[f64], sums: &mut Sums) {
    for j in 0..h.columns {
        let (w, v) = (weight[j], size[j] * weight[j]);
        let columns = h.padded_column(j).iter().zip(g.padded_column(j));
        let to = sums.s.iter_mut().zip(&mut sums.g).zip(&mut sums.plain);
        for (((s, weighed), plain), (h, g)) in to.zip(columns) {
            *s += h * w + g * v;
            *weighed += g * w;
            *plain += g;
        }
    }
}

/// About max_c (|s_cc - μ_c g_cc| + Σ_{c'} |h_cc'| + Σ_i h_ci² / gap_i).
#[inline(always)]
fn estimate_loops<const FUSED: bool>(pass: &mut Pass<'_>) {
    let rows = pass.rows;
    let gaps = pass.gaps.as_chunks::<LANES>().0;
    let mut most: f64 = 0.0;
    for c in pass.range.clone() {
        let column = rows.h.padded_column(c);
        let mut sums = [0.0; LANES];
        for (h, gap) in column.as_chunks::<LANES>().0.iter().zip(gaps) {
            for l in 0..LANES {
                sums[l] += h[l] * h[l] / gap[l];
            }
        }
        let own: f64 = column[pass.range.clone()].iter().sum();
        most = most.max(rows.defect[c] + own + sums.iter().sum::<f64>());
    }
    pass.needed = most;
}

#[inline(always)]
fn pass_loops<const FUSED: bool>(pass: &mut Pass<'_>) {
    let (rows, radius, factor) = (pass.rows, pass.radius, pass.factor);
    let reach = pass.width + radius;
    let top = pass.sigma + radius;
    // |s_ic - σ g_ic| <= |s_ic - μ_c g_ic| + |σ - μ_c| |g_ic| for columns c of the cluster.
    pass.tau.fill(0.0);
    for c in pass.range.clone() {
        let columns = rows.h.padded_column(c).iter().zip(rows.g.padded_column(c));
        for (tau, (h, g)) in pass.tau.iter_mut().zip(columns) {
            *tau += h + reach * g;
        }
    }
    // Rows of the cluster have an infinite gap, and so an infinite diagonal.
    let tau = pass.tau.as_chunks_mut::<LANES>().0;
    let gaps = pass.gaps.as_chunks::<LANES>().0;
    let least = rows.least.as_chunks::<LANES>().0;
    let defect = rows.defect.as_chunks::<LANES>().0;
    let weight = rows.weight.as_chunks::<LANES>().0;
    let s_sum = rows.s_sum.as_chunks::<LANES>().0;
    let g_sum = rows.g_sum.as_chunks::<LANES>().0;
    let (mut most, mut missing) = ([0.0_f64; LANES], [0.0_f64; LANES]);
    for k in 0..gaps.len() {
        for l in 0..LANES {
            let diagonal = diagonal(gaps[k][l] - radius, least[k][l], defect[k][l]);
            let rest = s_sum[k][l] + top * g_sum[k][l];
            let margin = margin(diagonal, weight[k][l], rest, factor);
            let ratio = tau[k][l] * factor / margin;
            // A margin that is no number counts as none.
            missing[l] += if margin > 0.0 { 0.0 } else { 1.0 };
            most[l] = if ratio > most[l] { ratio } else { most[l] };
        }
    }
    pass.separated = missing == [0.0; LANES];
    if !pass.separated {
        return;
    }
    let most = up(most.iter().fold(0.0, |x: f64, y| x.max(*y)));
    for k in 0..gaps.len() {
        for l in 0..LANES {
            let diagonal = diagonal(gaps[k][l] - radius, least[k][l], defect[k][l]);
            let rest = (s_sum[k][l] + top * g_sum[k][l]) * most;
            tau[k][l] = up((tau[k][l] + rest) * factor / (diagonal * (1.0 - 1e-14)));
        }
    }
    pass.tau[pass.range.clone()].fill(0.0);
    let tau = pass.tau.as_chunks::<LANES>().0;
    let mut needed: f64 = 0.0;
    for c in pass.range.clone() {
        let (h, g) = (rows.h.padded_column(c), rows.g.padded_column(c));
        let mut sums = [0.0; LANES];
        let columns = h.as_chunks::<LANES>().0.iter().zip(g.as_chunks::<LANES>().0);
        for (tau, (h, g)) in tau.iter().zip(columns) {
            for l in 0..LANES {
                sums[l] += (h[l] + reach * g[l]) * tau[l];
            }
        }
        let mut sum = rows.defect[c] + sums.iter().sum::<f64>();
        for i in pass.range.clone() {
            sum += h[i] + reach * g[i];
        }
        needed = needed.max(sum * factor / rows.least[c]);
    }
    pass.needed = needed;
}

impl Pass<'_> {
    /// The nearest row that is not dominant.
    fn culprit(&self, m: usize) -> usize {
        let (rows, radius) = (self.rows, self.radius);
        let dominant = |i: usize| {
            let diagonal = diagonal(self.gaps[i] - radius, rows.least[i], rows.defect[i]);
            let rest = rows.s_sum[i] + (self.sigma + radius) * rows.g_sum[i];
            margin(diagonal, rows.weight[i], rest, self.factor) > 0.0
        };
        let outside = (0..self.range.start).chain(self.range.end..m).filter(|&i| !dominant(i));
        outside.min_by(|&p, &q| self.gaps[p].total_cmp(&self.gaps[q])).unwrap_or(self.range.start)
    }
}
